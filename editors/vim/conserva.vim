" Vim 8 or newer with ALE (`apt install vim-ale`, or the plugin dense-analysis/ale): `source /path/to/conserva.vim` in .vimrc.
autocmd BufRead,BufNewFile *.rhai setfiletype rhai
silent! packadd ale

function! s:root(buffer) abort
    return fnamemodify(bufname(a:buffer), ':p:h')
endfunction

call ale#linter#Define('rhai', {
\   'name': 'conserva',
\   'lsp': 'stdio',
\   'executable': 'conserva',
\   'command': '%e lsp',
\   'project_root': function('s:root'),
\})

function! s:keys() abort
    setlocal commentstring=//\ %s omnifunc=ale#completion#OmniFunc
    " Colors: the highlighting of JavaScript fits the language.
    setlocal syntax=javascript
    nnoremap <buffer> K :ALEHover<CR>
    nnoremap <buffer> gd :ALEGoToDefinition<CR>
    nnoremap <buffer> gr :ALEFindReferences<CR>
    nnoremap <buffer> <F2> :ALERename<CR>
endfunction
autocmd FileType rhai call s:keys()
