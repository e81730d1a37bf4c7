"""The names of the tables of runs, which a command logs and the report reads."""

STRESS = "stress.json"

# Of an advice run.
SEARCH = "search.json"
CONTRIBUTIONS = "contributions.json"
REASONS = "reasons.json"
BUFFERS = "buffers.json"
FACTS = "facts.json"
SUMMARY = "summary.json"
ANSWER = "advice.yaml"  # the experiment file
