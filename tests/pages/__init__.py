"""What the pages of docs/ show: each table is computed here, held by a test, and rewritten by

python -m tests.pages            # all of them
python -m tests.pages edges end  # the tables of these names
"""
