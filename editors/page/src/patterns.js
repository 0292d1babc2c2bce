// Made by `make editors` from porelang/syntax/highlighting.py: what is found, tried in this order.
export const PATTERNS = [
  ["comment.documentation", "##(?!#)[^\\n]*"],
  ["comment", "#[^\\n]*"],
  ["string", "\"([^\"\\\\\\r\\n]|\\\\[^\\r\\n])*\""],
  ["number", "(?<!\\w)([0-9]+(\\.(?!\\.)[0-9]*)?|\\.[0-9]+)([eE][+-]?[0-9]+)?(%(?![A-Za-z0-9_(\\[]|\\.[0-9])|[A-Za-z_][A-Za-z0-9_]*)?"],
  ["keyword.declaration", "\\b(?:param|let|def|out|check|use|preset)\\b"],
  ["keyword", "\\b(?:if|then|else|for|in|where|and|or|not|as|step)\\b"],
  ["constant", "\\b(?:true|false|pi|tau)\\b"],
  ["variable.coordinate", "(?<![\\w.])[xyzp]\\b(?!\\s*[(=])"],
  ["function", "\\b[A-Za-z_]\\w*(?=\\s*\\()"],
  ["operator", "=>|\\|>|==|!=|<=|>=|\\.\\.|[=<>|&\\\\+\\-*/%^~@]"],
  ["variable", "[A-Za-z_]\\w*"],
];
