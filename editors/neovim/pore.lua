-- Neovim 0.11 or newer: copy to ~/.config/nvim/lsp/pore.lua, and put these two lines into init.lua:
--   vim.filetype.add({ extension = { pore = "pore" } })
--   vim.lsp.enable("pore")
return {
  cmd = { "pore", "lsp" },
  filetypes = { "pore" },
  root_markers = { ".git" },
}
