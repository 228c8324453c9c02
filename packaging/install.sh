#!/bin/sh
# Installs the command `starbreak` on Linux (x86-64 and aarch64 with glibc 2.28 or newer) and macOS:
# downloads its archive from the release that this script comes with, compares the SHA-256, and puts
# the binary into ~/.local/bin. Nothing else on the machine is changed.
#
#   STARBREAK_BIN    another folder for the binary
#   STARBREAK_FROM   another address of the release's files, e.g. a mirror's

set -eu

# The release fills this in.
from=${STARBREAK_FROM:-@FROM@}
bin=${STARBREAK_BIN:-${HOME:?}/.local/bin}

fail() {
    echo "starbreak: $1" >&2
    exit 1
}

target() {
    case "$(uname -s) $(uname -m)" in
    "Linux x86_64") echo x86_64-unknown-linux-gnu ;;
    "Linux aarch64") echo aarch64-unknown-linux-gnu ;;
    "Darwin x86_64") echo x86_64-apple-darwin ;;
    "Darwin arm64") echo aarch64-apple-darwin ;;
    *) fail "there is no binary for $(uname -s) on $(uname -m); build it: cargo install starbreak-cli" ;;
    esac
}

sha256() {
    if command -v sha256sum >/dev/null; then
        sha256sum "$1"
    elif command -v shasum >/dev/null; then
        shasum -a 256 "$1"
    else
        fail "there is neither sha256sum nor shasum to check the download with"
    fi
}

# A function, so that half a script does nothing.
main() {
    name=starbreak-$(target)
    tmp=$(mktemp -d)
    trap 'rm -rf "$tmp"' EXIT
    for file in "$name.tar.gz" SHA256SUMS; do
        curl -fsSL "$from/$file" -o "$tmp/$file" || fail "$from/$file did not come"
    done
    wanted=$(awk -v file="$name.tar.gz" '$2 == file { print $1 }' "$tmp/SHA256SUMS")
    got=$(sha256 "$tmp/$name.tar.gz" | cut -d ' ' -f 1)
    [ -n "$wanted" ] || fail "SHA256SUMS does not name $name.tar.gz"
    [ "$got" = "$wanted" ] || fail "$name.tar.gz has SHA-256 $got, and the release says $wanted"
    tar -xzf "$tmp/$name.tar.gz" -C "$tmp"
    mkdir -p "$bin"
    # Renamed into its place: one that runs is not written over.
    cp "$tmp/$name/starbreak" "$bin/.starbreak.new"
    mv "$bin/.starbreak.new" "$bin/starbreak"
    echo "$("$bin/starbreak" --version) is in $bin"
    case ":$PATH:" in
    *":$bin:"*) ;;
    *) echo "$bin is not on the PATH: add it, e.g. export PATH=\"$bin:\$PATH\"" ;;
    esac
}

main
