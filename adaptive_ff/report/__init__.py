"""Results for people: pictures, tables, diagnosis, files."""
