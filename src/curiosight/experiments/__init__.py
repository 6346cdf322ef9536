"""What the commands do: each reads a recording and writes a folder of results."""
