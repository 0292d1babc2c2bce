"""The language server, `pore lsp`: what `porelang.assist` tells, in the words of the Language Server Protocol."""
