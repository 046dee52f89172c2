// Photographs that a warning names, and whether it says to leave them out.

const kEnds = '(?=$|[\\s,;:)"\'’]|\\.(?:\\s|$))'

/** Those of `names` that stand in the text as words. */
export function namedIn(text: string, names: string[]): string[] {
  const escaped = (name: string) => name.replace(/[.*+?^${}()|[\]\\]/g, '\\$&')
  return names.filter((name) =>
    new RegExp(`(?:^|[\\s,;:("'‘/])${escaped(name)}${kEnds}`, 'u').test(text),
  )
}

export function saysLeaveOut(text: string): boolean {
  return /\bleav\w* (?:[^.;]* )?out\b|\bleft out\b|\bblurred\b|\bidentical\b|\bcannot be read\b|\bdamaged\b|\bcut off\b/iu.test(text)
}
