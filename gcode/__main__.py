"""``python -m gcode`` does what the console command ``gcode`` does."""

from gcode.cli import main

raise SystemExit(main())
