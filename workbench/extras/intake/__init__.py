"""Tables of tests from elsewhere into the user's own data, checked before anything is written."""
