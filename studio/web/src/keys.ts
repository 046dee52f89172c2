// Keys of a page: who listens, and which keys fields and buttons keep for themselves.
import { useEffect, useRef } from 'preact/hooks'

/** Names as KeyboardEvent.key in lower case, with 'ctrl+' and 'shift+' before it. */
export type KeyMap = Record<string, (event: KeyboardEvent) => void>

function nameOf(event: KeyboardEvent): string {
  const ctrl = event.ctrlKey || event.metaKey ? 'ctrl+' : ''
  const letter = event.key.length === 1 ? event.key.toLowerCase() : event.key
  const shift = event.shiftKey && event.key.length > 1 ? 'shift+' : ''
  const shiftLetter = event.shiftKey && ctrl ? 'shift+' : ''
  return `${ctrl}${shift || shiftLetter}${letter}`
}

/** Keys that a button, a link or a menu needs for itself. */
const kOwn = new Set(['Enter', ' '])

function isTyping(target: EventTarget | null): boolean {
  if (target instanceof HTMLInputElement) return target.type !== 'range'
  return target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement
}

function keepsKey(event: KeyboardEvent): boolean {
  const { target } = event
  if (isTyping(target)) return event.key !== 'Escape'
  if (target instanceof HTMLInputElement) return event.key.startsWith('Arrow')
  const own = target instanceof Element && target.closest('button, a, summary')
  if (!own || event.ctrlKey || event.metaKey || !kOwn.has(event.key)) return false
  // Enter on a row of a list accepts or renames what the row stands for.
  return !(event.key === 'Enter' && (own as HTMLElement).dataset.row)
}

/** Listens in the whole window while the page is shown. */
export function useKeys(map: KeyMap): void {
  const latest = useRef(map)
  latest.current = map
  useEffect(() => {
    const listen = (event: KeyboardEvent) => {
      if (event.defaultPrevented || event.altKey || keepsKey(event)) return
      const act = latest.current[nameOf(event)]
      if (!act) return
      event.preventDefault()
      act(event)
    }
    addEventListener('keydown', listen)
    return () => removeEventListener('keydown', listen)
  }, [])
}
