"""Controllers compared on scenarios: registry, runs, comparison, drawn joints, regression gate."""
