-- Neovim 0.7 or newer: `require("conserva")` in init.lua, with this file in the folder `lua` beside it.
local start = vim.lsp.start or function(settings)
    -- Neovim 0.7
    local client = vim.g.conserva_client or vim.lsp.start_client(settings)
    vim.g.conserva_client = client
    vim.lsp.buf_attach_client(0, client)
end

vim.api.nvim_create_autocmd({ "BufRead", "BufNewFile" }, {
    pattern = "*.rhai",
    callback = function()
        vim.bo.filetype = "rhai"
        vim.bo.commentstring = "// %s"
        vim.bo.omnifunc = "v:lua.vim.lsp.omnifunc"
        start({ name = "conserva", cmd = { "conserva", "lsp" }, root_dir = vim.fn.getcwd() })
        local key = function(keys, action)
            vim.keymap.set("n", keys, action, { buffer = true })
        end
        key("K", vim.lsp.buf.hover)
        key("gd", vim.lsp.buf.definition)
        key("gr", vim.lsp.buf.references)
        key("<F2>", vim.lsp.buf.rename)
        key("<F3>", function() (vim.lsp.buf.format or vim.lsp.buf.formatting_sync)() end)
        -- Colors: the highlighting of JavaScript fits the language.
        vim.bo.syntax = "javascript"
    end,
})
