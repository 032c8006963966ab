#!/usr/bin/env bash
# Makes the files that are handed out, in a folder (by default dist/): the wheel, the program, and a Debian package with the completions of
# shells and the manual pages. The program is static where the target with musl is installed (`rustup target add
# x86_64-unknown-linux-musl`, and `musl-gcc`); elsewhere it needs the glibc of this machine or a newer one, and says so.
set -euo pipefail
cd "$(dirname "$0")/.."
out="${1:-dist}"
mkdir -p "$out"
version="$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)"

maturin build --quiet --release --locked -m python/Cargo.toml -i "${PYTHON:-python3}" --out "$out"

musl="$(uname -m)-unknown-linux-musl"
if rustup target list --installed 2>/dev/null | grep -qx "$musl" && command -v musl-gcc >/dev/null; then
    cargo build --release --locked --target "$musl" --bin conserva
    built="target/$musl/release/conserva"
    needs=""
else
    cargo build --release --locked --bin conserva
    built="target/release/conserva"
    glibc="$(grep -ao 'GLIBC_2\.[0-9]*' "$built" | sort -uV | tail -1 | sed 's/GLIBC_//')"
    needs="Depends: libc6 (>= $glibc), libgcc-s1"
    echo "the target $musl is not installed: the program is linked with glibc and needs $glibc or newer" >&2
fi
program="$out/conserva-$version-$(uname -s | tr '[:upper:]' '[:lower:]')-$(uname -m)"
install -m 755 "$built" "$program"
strip "$program"

if ! command -v dpkg-deb >/dev/null; then
    echo "SKIPPED: dpkg-deb is not here, so no Debian package is made" >&2
    exit 0
fi
tree="$(mktemp -d)"
trap 'rm -rf "$tree"' EXIT
chmod 755 "$tree"
share="$tree/usr/share"
install -Dm 755 "$program" "$tree/usr/bin/conserva"
install -d "$share/man/man1" "$share/doc/conserva" "$share/bash-completion/completions" "$share/zsh/vendor-completions" \
    "$share/fish/vendor_completions.d" "$tree/DEBIAN"
"$program" completions bash >"$share/bash-completion/completions/conserva"
"$program" completions zsh >"$share/zsh/vendor-completions/_conserva"
"$program" completions fish >"$share/fish/vendor_completions.d/conserva.fish"
"$program" man | gzip -9n >"$share/man/man1/conserva.1.gz"
for command in run resume sweep check test doc new list info diff export repl completions man; do
    "$program" man "$command" | gzip -9n >"$share/man/man1/conserva-$command.1.gz"
done
cat LICENSE-APACHE LICENSE-MIT THIRD-PARTY-LICENSES.md >"$share/doc/conserva/copyright"
{
    echo "Package: conserva"
    echo "Version: $version"
    echo "Architecture: $(dpkg --print-architecture)"
    echo "Maintainer: the authors of Conserva"
    echo "Section: science"
    echo "Priority: optional"
    if [ -n "$needs" ]; then echo "$needs"; fi
    echo "Description: contact dynamics that conserves energy and momentum"
    echo " A scripting engine for the dynamics of deformable and rigid bodies in contact."
} >"$tree/DEBIAN/control"
dpkg-deb --root-owner-group -Zxz -z1 --build "$tree" "$out/conserva_${version}_$(dpkg --print-architecture).deb" >/dev/null
ls -l "$out"
