// Numbers and states in words.

/** "3 s", "2 min 05 s", "1 h 12 min" */
export function duration(seconds: number): string {
  const whole = Math.round(seconds)
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`
  if (whole < 60) return `${whole} s`
  const two = (value: number) => String(Math.floor(value)).padStart(2, '0')
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${two(whole % 60)} s`
  return `${Math.floor(whole / 3600)} h ${two((whole % 3600) / 60)} min`
}

/** To 5 seconds, minutes, or 10 minutes; never zero. */
function rounded(seconds: number): { number: number; text: string; unit: string } {
  if (seconds < 57.5) {
    const number = Math.max(5, 5 * Math.round(seconds / 5))
    return { number, text: String(number), unit: 's' }
  }
  if (seconds < 59.5 * 60) {
    const minutes = Math.max(1, Math.round(seconds / 60))
    return { number: 60 * minutes, text: String(minutes), unit: 'min' }
  }
  const tens = Math.max(6, Math.round(seconds / 600))
  const hours = String(Math.floor(tens / 6))
  if (tens % 6 === 0) return { number: 600 * tens, text: hours, unit: 'h' }
  return { number: 600 * tens, text: `${hours} h ${(tens % 6) * 10}`, unit: 'min' }
}

/** "2 min 05 s" where it is known well, else "2 to 5 min", "40 s to 2 min"; as the terminal says it. */
export function durationRange(likely: number, range: [number, number]): string {
  const [low, high] = range
  if (high <= 1.35 * low) return duration(likely)
  const from = rounded(low)
  const to = rounded(high)
  if (from.number === to.number) return `about ${to.text} ${to.unit}`
  if (from.unit === to.unit && to.number < 3600) return `${from.text} to ${to.text} ${to.unit}`
  return `${from.text} ${from.unit} to ${to.text} ${to.unit}`
}

/** "1.2 MB" */
export function bytes(count: number): string {
  if (count >= 1e9) return `${(count / 1e9).toFixed(1)} GB`
  if (count >= 1e6) return `${(count / 1e6).toFixed(1)} MB`
  return `${Math.ceil(count / 1e3)} kB`
}

export function percent(share: number, digits = 0): string {
  return `${(100 * share).toFixed(digits)} %`
}

/** "1 photograph", "3 photographs" */
export function count(number: number, noun: string): string {
  return `${number} ${noun}${number === 1 ? '' : 's'}`
}

/** "Texture layout of rest" for `unwrap/rest`, as its stage calls it; the id where none is known. */
export function stepName(id: string, steps: { id: string; title: string; pose: string }[]): string {
  const step = steps.find((one) => one.id === id)
  if (!step) return id
  return step.pose ? `${step.title} of ${step.pose}` : step.title
}

/** What its stage calls it: "Texture layout"; of a warning, which names a step of all poses, too. */
export function stepTitle(id: string, steps: { id: string; step: string; title: string }[]): string {
  return steps.find((one) => one.id === id || one.step === id)?.title ?? id
}

/** Words of a program as a sentence: a capital first, a full stop last. */
export function sentence(words: string): string {
  const text = words.trim()
  if (!text) return ''
  const first = String.fromCodePoint(text.codePointAt(0)!)
  return (
    first.toLocaleUpperCase('en') + text.slice(first.length) + (/[.!?…]$/.test(text) ? '' : '.')
  )
}

/**
 * A share as a width for CSS: "45%". The text of `percent` has a space, which CSS does not take.
 */
export function cssShare(share: number): string {
  return `${(100 * Math.min(1, Math.max(0, share))).toFixed(1)}%`
}
