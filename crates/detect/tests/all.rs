//! All tests of detectors as one program, which is built and run sooner than one for each file.

mod contracts;
mod hostile;
mod onnx_graph;
mod resize;
mod runtime;
mod words;
