#!/bin/sh
# Builds the documents as a searchable site in target/site, without a network; needs mdBook (cargo install --locked mdbook).
set -e
cd "$(dirname "$0")/.."
exec cargo run --release --locked --features examples --example site -- "$@"
