"""Prints the library in the package onnxruntime, which is not imported, or nothing."""

import sys

# What lies in the present folder is no package: a dataset could bring one along.
sys.path[:] = [path for path in sys.path if path]

import importlib.util  # noqa: E402
import pathlib  # noqa: E402

spec = importlib.util.find_spec("onnxruntime")
files = sorted(pathlib.Path(spec.submodule_search_locations[0], "capi").iterdir()) if spec else []
print(next((file for file in files if file.name.startswith(("libonnxruntime.", "onnxruntime.dll"))), ""))
