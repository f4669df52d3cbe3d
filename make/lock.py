"""Write a lock file: version and hash of each package that CI installs, on this kind of machine with this Python.

Usage: lock.py FILE. Installed from it with `pip install --require-hashes`, packages are those of that day, to the bit.
"""

import json
import subprocess
import sys
import tomllib

EXTRAS = ("test", "lint", "docs", "fe", "radio", "studio")  # extras that .ci/run installs
PIP = (sys.executable, "-m", "pip", "install", "--quiet", "--dry-run", "--ignore-installed", "--report", "-")


def wanted():
    """Return the requirements of pyproject.toml that CI installs."""
    with open("pyproject.toml", "rb") as file:
        table = tomllib.load(file)
    extras = table["project"]["optional-dependencies"]
    return [
        *table["build-system"]["requires"],
        *table["project"]["dependencies"],
        *(one for extra in EXTRAS for one in extras[extra]),
    ]


def lines(report):
    """Return a line of the lock file for each package of pip's report."""
    for package in sorted(report["install"], key=lambda one: one["metadata"]["name"].lower()):
        about, hashes = package["metadata"], package["download_info"]["archive_info"]["hashes"]
        yield f"{about['name']}=={about['version']} --hash=sha256:{hashes['sha256']}\n"


if __name__ == "__main__":
    report = json.loads(subprocess.run([*PIP, *wanted()], check=True, stdout=subprocess.PIPE).stdout)
    kind = "Python {python_version} on {sys_platform}, {platform_machine}".format_map(report["environment"])
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write(f"# Written by `make lock`: {kind}.\n")
        file.writelines(lines(report))
