"""The paper beside ours: its published runs made again, and what its claims come to."""
