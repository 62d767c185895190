"""What is said of an identified joint: verdict, cautions, scenario."""
