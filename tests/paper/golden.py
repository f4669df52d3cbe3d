"""Write golden.json from a ledger: hypertuna paper --json | python tests/paper/golden.py."""

import json
import sys
from pathlib import Path

if __name__ == "__main__":
    entries = json.load(sys.stdin)["entries"]
    rows = {f"{one['id']} | {one['model']}": [one["computed"], one["class"], one["verdict"]] for one in entries}
    lines = ",\n".join(f"  {json.dumps(key)}: {json.dumps(row)}" for key, row in rows.items())
    Path(__file__).with_name("golden.json").write_text(f"{{\n{lines}\n}}\n")
