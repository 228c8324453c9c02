#!/usr/bin/env bash
# Prints what CHANGELOG.md says of a version; fails if that is nothing.
#
#   packaging/release-notes.sh 0.1.0
set -euo pipefail
notes=$(awk -v heading="## [$1]" '
    /^## / { of_version = index($0, heading) == 1; next }
    of_version' "$(dirname "$0")/../CHANGELOG.md")
if [ -z "${notes//[[:space:]]/}" ]; then
    echo "CHANGELOG.md says nothing under \"## [$1]\"" >&2
    exit 1
fi
printf '%s\n' "$notes"
