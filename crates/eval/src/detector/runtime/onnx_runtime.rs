//! The other backend: ONNX Runtime, loaded at run time.
