"""The controller in a browser: one page on which a loop runs from the kernels of this package."""
