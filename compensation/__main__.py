"""``python -m compensation`` does what the console command ``compensation`` does."""

from compensation.cli import main

raise SystemExit(main())
