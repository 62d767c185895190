"""From a log to the rows that are regressed: columns of the equation of motion, all in one band."""
