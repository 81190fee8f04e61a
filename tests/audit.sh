#!/bin/sh
# Known vulnerabilities of the locked packages by pip-audit, where an index and a database answer; never fails.
cd "$(dirname "$0")/.." || exit 0
folder=$(mktemp -d) || exit 0
trap 'rm -rf "$folder"' EXIT
for step in "download -q --no-deps -d $folder" "install -q --target $folder/lib"; do  # the first tells in seconds whether one answers
  timeout 150 python3 -m pip $step --retries 0 --timeout 5 pip-audit > /dev/null 2>&1 \
    || { echo "pip-audit could not be fetched: the lock is not audited."; exit 0; }
done
PYTHONPATH="$folder/lib" timeout 120 python3 -m pip_audit --disable-pip --timeout 5 --progress-spinner off \
  -r envs/requirements.txt > "$folder/found" 2>&1
grep -i -A99 "known vulnerabilities" "$folder/found" || echo "No database of vulnerabilities answers: the lock is not audited."
exit 0
