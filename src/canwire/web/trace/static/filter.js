// Filters and colour rules: "100-1FF, !123, error, rtr, fd, sent" in words of one line.

const WORDS = {
  error: (rows, place) => rows.error(place),
  event: (rows, place) => !rows.frame(place),
  frame: (rows, place) => rows.frame(place),
  lin: (rows, place) => rows.lin(place),
  can: (rows, place) => !rows.lin(place),
  rtr: (rows, place) => rows.kind(place) === 0 && (rows.info(place) & (1 << 22)) !== 0,
  fd: (rows, place) => rows.kind(place) === 0 && (rows.info(place) & (1 << 10)) !== 0,
  ext: (rows, place) => rows.kind(place) === 0 && rows.extended(place),
  std: (rows, place) => rows.kind(place) === 0 && !rows.extended(place),
};

/** A test of (rows, place), or null for an empty text; throws the part that means nothing. `names`: id -> message. */
export function compile(text, names = {}) {
  const wanted = [];
  const refused = [];
  for (const part of text.split(/[,;]/).map((one) => one.trim()).filter(Boolean)) {
    const not = part.startsWith("!");
    (not ? refused : wanted).push(term(not ? part.slice(1).trim() : part, part, names));
  }
  if (!wanted.length && !refused.length) return null;
  return (rows, place) =>
    (!wanted.length || wanted.some((test) => test(rows, place))) && !refused.some((test) => test(rows, place));
}

function term(text, part, names) {
  const known = WORDS[text.toLowerCase()];
  if (known) return known;
  const range = /^(?:0x)?([0-9a-f]{1,8})(?:\s*-\s*(?:0x)?([0-9a-f]{1,8}))?$/i.exec(text);
  if (range) {
    const from = parseInt(range[1], 16);
    const to = range[2] ? parseInt(range[2], 16) : from;
    if (from > to) throw part;
    return (rows, place) => {
      const id = rows.id(place);
      return rows.frame(place) && id >= from && id <= to;
    };
  }
  const like = text.toLowerCase();
  const ids = new Set(Object.keys(names).filter((id) => names[id].toLowerCase().includes(like)));
  if (!ids.size) throw part;
  return (rows, place) => rows.frame(place) && ids.has(rows.idText(place));
}
