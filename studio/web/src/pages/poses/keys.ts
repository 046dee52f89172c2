// Arrow keys among things in rows.

/** The number of the thing that a key goes to, or null if the key means nothing here. */
export function nextByKey(
  event: KeyboardEvent,
  count: number,
  current: number,
  columns: number,
): number | null {
  if (count === 0 || event.ctrlKey || event.metaKey || event.altKey) return null
  const steps: Record<string, number> = {
    ArrowLeft: -1,
    ArrowRight: 1,
    ArrowUp: -columns,
    ArrowDown: columns,
  }
  if (event.key === 'Home') return 0
  if (event.key === 'End') return count - 1
  const step = steps[event.key]
  if (step === undefined) return null
  const next = current + step
  return next >= 0 && next < count ? next : current
}

/** True where a key is text or moves a form's own handle. */
export function inField(event: KeyboardEvent): boolean {
  const target = event.target as HTMLElement
  return target.matches('input, select, textarea')
}
