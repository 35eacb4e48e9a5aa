/**
 * Places in text. The server counts characters as Unicode scalar values; a text area counts UTF-16 units.
 */

/** The UTF-16 offset of the scalar offset `scalars`. */
export function utf16Offset(text: string, scalars: number): number {
  let offset = 0;
  for (let left = scalars; left > 0 && offset < text.length; left--) {
    offset += (text.codePointAt(offset) ?? 0) > 0xffff ? 2 : 1;
  }
  return offset;
}

/** Line and column, both from 1, of a UTF-16 offset. */
export function lineAndColumn(text: string, offset: number): { line: number; column: number } {
  const before = text.slice(0, offset).split('\n');
  return { line: before.length, column: [...(before.at(-1) ?? '')].length + 1 };
}

/** What a name in an address is: a pattern, and the same in words. */
export const NAME = { pattern: '[a-z0-9][a-z0-9\\-]{0,62}', hint: 'Small letters, digits and hyphens, 63 at most' };

/** A name for a world or a programme, made from its title. */
export function slug(title: string): string {
  return title
    .normalize('NFKD')
    .replace(/\p{M}/gu, '')
    .toLowerCase()
    .replace(/[^a-z0-9]+/g, '-')
    .replace(/^-+/, '')
    .slice(0, 63)
    .replace(/-+$/, '');
}
