#!/usr/bin/env bash
# Publishes to crates.io, in the order of their dependencies, those of our crates whose version is
# not there yet; so it may be run again after it stopped half-way. Cargo finds the token in
# CARGO_REGISTRY_TOKEN. Arguments are passed on to `cargo publish`, e.g. --dry-run.
set -euo pipefail
cd "$(dirname "$0")/.."
agent="starbreak-release (packaging/publish-crates.sh)"
there=()
missing=0
while read -r name version; do
    url=https://crates.io/api/v1/crates/$name/$version
    status=$(curl -sS -A "$agent" -o /dev/null -w '%{http_code}' "$url")
    case $status in
    200)
        echo "$name $version is there"
        there+=(--exclude "$name")
        ;;
    404) missing=$((missing + 1)) ;;
    *)
        echo "$url: status $status" >&2
        exit 1
        ;;
    esac
    sleep 1 # crates.io asks for no more than one question per second
done < <(cargo metadata --locked --no-deps --format-version 1 |
    jq -r '.packages[] | select(.publish != []) | "\(.name) \(.version)"')
if [ "$missing" -eq 0 ]; then
    exit 0
fi
cargo publish --workspace --locked "${there[@]}" "$@"
