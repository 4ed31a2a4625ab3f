"""One file a page. A page is a function that builds itself from the studio and the address's query."""
