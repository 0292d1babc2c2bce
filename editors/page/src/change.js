// The smallest change that makes one text of another, and where a place of the first is in the second.

export function change(old, fresh) {
  const most = Math.min(old.length, fresh.length);
  let from = 0, end = 0;
  while (from < most && old[from] === fresh[from]) from++;
  while (end < most - from && old[old.length - 1 - end] === fresh[fresh.length - 1 - end]) end++;
  return { from, to: old.length - end, insert: fresh.slice(from, fresh.length - end) };
}

const inked = (text) => text.replace(/\s+/g, "");

export function kept(old, fresh, { from, to, insert }, place) {
  if (place <= from) return place;
  if (place >= to) return place + fresh.length - old.length;
  const gone = old.slice(from, to), before = old.slice(from, place);
  // text that was only set anew has the same signs: the place is behind as many of them, and before the same
  if (inked(gone) === inked(insert)) {
    let signs = inked(before).length, at = 0;
    for (; signs > 0; at++) if (/\S/.test(insert[at])) signs--;
    if (/\s\S/.test(old.slice(place - 1, place + 1))) while (/\s/.test(insert[at] ?? "")) at++;
    return from + at;
  }
  // else it stays in its line and column, as far as there are such
  const lines = old.slice(0, place).split("\n"), now = fresh.split("\n");
  const row = Math.min(lines.length, now.length) - 1;
  const column = Math.min(lines.at(-1).length, now[row].length);
  return now.slice(0, row).reduce((sum, line) => sum + line.length + 1, column);
}
