"""The command line as ``python -m adaptive_ff``."""

from adaptive_ff.cli.main import main

if __name__ == "__main__":
    main()
