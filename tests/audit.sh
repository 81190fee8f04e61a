#!/bin/sh
# Known vulnerabilities of the locked packages by pip-audit, where an index and a database answer; never fails.
cd "$(dirname "$0")/.." || exit 0
DATABASE=https://pypi.org/pypi/numpy/$(sed -n 's/^numpy==\([0-9.]*\).*/\1/p' envs/requirements.txt)/json # as pip-audit asks it
python3 -c "import urllib.request as web; web.urlopen('$DATABASE', timeout=5)" > /dev/null 2>&1 \
  || { echo "The lock is not audited: no database answers."; exit 0; }
folder=$(mktemp -d) || exit 0
trap 'rm -rf "$folder"' EXIT
for step in "download -q --no-deps -d $folder" "install -q --target $folder/lib"; do  # the first tells in seconds whether one answers
  timeout 60 python3 -m pip $step --retries 0 --timeout 5 pip-audit > /dev/null 2>&1 \
    || { echo "pip-audit could not be fetched: the lock is not audited."; exit 0; }
done
PYTHONPATH="$folder/lib" timeout 60 python3 -m pip_audit --disable-pip --timeout 5 --progress-spinner off \
  -r envs/requirements.txt -r envs/requirements-test.txt -f json -o "$folder/found" > /dev/null 2>&1
python3 - "$folder/found" <<'END'
import json
import sys

try:
    packages = json.load(open(sys.argv[1]))["dependencies"]
except (OSError, ValueError, KeyError):
    packages = []
audited = [each for each in packages if "vulns" in each]  # others were not found in the database
for each in audited:
    for found in each["vulns"]:
        print(each["name"], each["version"], found["id"], "fixed in", *found["fix_versions"])
print(f"{len(audited)} of {len(packages)} locked packages audited." if audited else "The lock is not audited: no database answers.")
END
exit 0
