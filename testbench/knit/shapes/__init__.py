"""Curves, loops and waves of any shape, linear in their weights; base laws get their shape freedom from them."""
