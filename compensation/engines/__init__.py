"""Networks and the ways to fit one."""
