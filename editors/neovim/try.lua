-- Opens main.rhai and looks at what the server tells; ends Neovim with 1 if something is missing.
local function ends(text)
    io.stdout:write(text .. "\n")
    vim.cmd("cquit 1")
end

local function wait(what, condition)
    if not vim.wait(20000, condition, 20) then
        ends("nothing arrived: " .. what)
    end
end

vim.cmd("edit main.rhai")
local function told(text)
    return function()
        for _, message in ipairs(vim.diagnostic.get(0)) do
            if message.message:find(text, 1, true) then
                return true
            end
        end
        return false
    end
end

local function ask(method, line, column, more)
    local parameters = { textDocument = vim.lsp.util.make_text_document_params(), position = { line = line, character = column } }
    local answers = vim.lsp.buf_request_sync(0, method, vim.tbl_extend("force", parameters, more or {}), 20000)
    for _, answer in pairs(answers or {}) do
        return vim.inspect(answer.result)
    end
    return ""
end

-- The unfinished line first, then the mistake of the line before.
wait("the message of a text that does not parse", function() return #vim.diagnostic.get(0) > 0 end)
if not ask("textDocument/completion", 2, 6):find("boundary_where", 1, true) then
    ends("no completion of `plate.`")
end
vim.api.nvim_buf_set_lines(0, 2, 3, false, { "print(plate);" })
wait("the message of a boundary that does not exist", told('did you mean "bottom"'))
if not ask("textDocument/hover", 0, 15):find("rectangle", 1, true) then
    ends("no help of `rectangle`")
end
if not ask("textDocument/rename", 0, 5, { newName = "sheet" }):find("sheet", 1, true) then
    ends("no renaming of `plate`")
end
vim.cmd("qall!")
