#!/bin/sh
# Opens a script with a mistake in Neovim, Emacs and Vim with ALE, without a screen, and looks at what arrives: messages, completion, help, renaming.
# The first argument is the folder of the program `conserva` if that is not on the search path.
set -e
here=$(cd "$(dirname "$0")" && pwd)
PATH="${1:-/usr/bin}:$PATH"
export PATH
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cat > "$folder/main.rhai" <<'SCRIPT'
let plate = rectangle(#{ size: [2.0, 1.0], cells: [4, 2] });
let edge = plate.boundary("botom");
plate.
SCRIPT
failed=0
try() {
    if command -v "$1" > /dev/null; then
        if timeout 120 "$@" < /dev/null > "$folder/log" 2>&1; then echo "$1: all arrived"; else echo "$1: failed"; cat "$folder/log"; failed=1; fi
    else
        echo "$1: not on this machine"
    fi
}
cd "$folder"
try nvim --headless --clean --cmd "set runtimepath+=$here/neovim" -c "luafile $here/neovim/conserva.lua" -c "luafile $here/neovim/try.lua"
try vim --not-a-term -T dumb -N -u NONE -i NONE --cmd "filetype plugin on" -S "$here/vim/conserva.vim" -c "edit main.rhai" \
    -S "$here/vim/try.vim"
try emacs --batch -l "$here/emacs/conserva.el" -l "$here/emacs/try.el"
exit $failed
