"""A folder in; a `Recording` out: one file and one class a layout.

How they are told apart stands in `datasets/__init__.py`. Read `folder.py` first.
"""
