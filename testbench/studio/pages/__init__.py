"""One file a page, a function that builds itself from studio and address; `campaign`: the pages of one campaign."""
