"""Compensators for a chip (C) and for ONNX."""
