"""Work that outlives a page: a command that runs, what it says, and how fast it gets on."""
