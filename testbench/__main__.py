"""``python -m testbench`` does what the console command ``testbench`` does."""

from testbench.cli import main

raise SystemExit(main())
