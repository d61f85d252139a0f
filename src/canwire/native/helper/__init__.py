"""The process beside a program in C: it holds the connection to the hub, and answers what is asked seldom."""
