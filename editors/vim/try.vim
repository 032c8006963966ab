" Opens main.rhai and looks at what the server tells; ends Vim with 1 if something is missing.
function! s:ends(text) abort
    call writefile([a:text], '/dev/stderr')
    cquit 1
endfunction

function! s:wait(what, Condition) abort
    for _ in range(400)
        if a:Condition()
            return
        endif
        sleep 50m
    endfor
    call s:ends('nothing arrived: ' . a:what)
endfunction

function! s:told(text) abort
    let l:messages = get(get(g:ale_buffer_info, bufnr(''), {}), 'loclist', [])
    return !empty(filter(copy(l:messages), 'stridx(v:val.text, a:text) >= 0'))
endfunction

" The unfinished line first, then the mistake of the line before.
call s:wait('the message of a text that does not parse', {-> s:told('')})
call cursor(3, 1)
function! TryNote() abort
    let s:offered = map(complete_info(['items']).items, 'v:val.word')
    return ''
endfunction
let s:offered = []
execute "normal! A\<C-X>\<C-O>\<C-R>=TryNote()\<CR>\<C-E>"
if index(s:offered, 'boundary_where') < 0
    call s:ends('no completion of `plate.`: ' . join(s:offered[:5]))
endif
call setline(3, 'print(plate);')
ALELint
call s:wait('the message of a boundary that does not exist', {-> s:told('did you mean "bottom"')})
call cursor(1, 16)
let g:ale_hover_to_preview = 1
ALEHover
call s:wait('help of `rectangle`', {-> !empty(filter(range(1, bufnr('$')), 'join(getbufline(v:val, 1, "$")) =~# "plane mesh\\|rectangle("  && bufname(v:val) !=# "main.rhai"'))})
qall!
