"""The score document and its picture."""
