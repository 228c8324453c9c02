#!/usr/bin/env bash
# Packs the command for a release: the binary, README, CHANGELOG, our licences and those of what is
# linked. Prints the archive's path.
#
#   packaging/archive.sh TARGET BINARY THIRD_PARTY_LICENCES OUTPUT_FOLDER
set -euo pipefail
target=$1 binary=$2 third_party=$3 out=$4
name=starbreak-$target
mkdir -p "$out/$name"
# The links in apps/cli are left alone: the files themselves lie here.
root=$(dirname "$0")/..
cp "$binary" "$root"/{README.md,CHANGELOG.md,LICENSE-MIT,LICENSE-APACHE} "$out/$name/"
cp "$third_party" "$out/$name/LICENSE-THIRD-PARTY.txt"
cd "$out"
case $target in
*windows*)
    7z a -bso0 "$name.zip" "$name"
    echo "$out/$name.zip"
    ;;
*)
    tar -czf "$name.tar.gz" "$name"
    echo "$out/$name.tar.gz"
    ;;
esac
rm -r "$name"
