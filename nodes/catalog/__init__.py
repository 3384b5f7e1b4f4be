"""Facts about the library as a whole: absent types and runnable examples."""
