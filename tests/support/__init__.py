"""What tests in several folders share: small worlds, texts of files, programs run in a process of their own."""
