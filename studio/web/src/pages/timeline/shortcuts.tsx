// The keyboard, and the list of it.
import { useEffect, useRef } from 'preact/hooks'

/** What a key does; its name as in KeyboardEvent.key, with Ctrl+ or Shift+ before it. */
export type Actions = Record<string, () => void>

function nameOf(event: KeyboardEvent): string {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key
  const control = event.ctrlKey || event.metaKey
  const shift = event.shiftKey && (control || /^[a-z]$/.test(key))
  return `${control ? 'Ctrl+' : ''}${shift ? 'Shift+' : ''}${key}`
}

/** Fields keep their keys; a button that was reached by keyboard keeps the space bar. */
function isTaken(event: KeyboardEvent): boolean {
  const target = event.target as HTMLElement
  if (target.closest('input, select, textarea, [role="menu"]')) return true
  const button = target.closest('button')
  return event.key === ' ' && button !== null && !button.classList.contains('tl-block')
}

export function useShortcuts(actions: Actions): void {
  const latest = useRef(actions)
  latest.current = actions
  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      const action = event.altKey || isTaken(event) ? undefined : latest.current[nameOf(event)]
      if (!action || event.defaultPrevented) return
      event.preventDefault()
      action()
    }
    addEventListener('keydown', key)
    return () => removeEventListener('keydown', key)
  }, [])
}

/** Keys, and what they do. */
export type HelpLines = [string, string][]

const kHelp: HelpLines = [
  ['Space', 'play, pause'],
  [', .', 'a frame back, on'],
  ['Home End', 'first, last frame'],
  ['R', 'play again and again'],
  ['O', 'onion skin; Shift+O keeps this frame'],
  ['K', 'new key at the playhead'],
  ['↑ ↓', 'key before, after'],
  ['← →', 'move the key by a frame; Shift: by ten'],
  ['Alt ← →', 'shorter, longer hold'],
  ['Ctrl+D', 'copy the key to the playhead'],
  ['Del', 'delete the key'],
  ['Ctrl+Z', 'undo; Ctrl+Shift+Z: redo'],
  ['+ − F', 'fewer, more, all frames on the ruler'],
  ['drag', 'Alt copies; Shift takes all later keys along'],
  ['wheel', 'scrolls the ruler; Ctrl zooms'],
]

export function Help({ close, lines = kHelp }: { close: () => void; lines?: HelpLines }) {
  const box = useRef<HTMLDivElement>(null)
  useEffect(() => box.current?.focus(), [])
  return (
    <div
      ref={box}
      class="tl-help"
      role="dialog"
      aria-label="Keys of the keyboard"
      tabIndex={-1}
      onKeyDown={(event) => event.key === 'Escape' && close()}
    >
      <dl>
        {lines.map(([keys, what]) => (
          <div key={keys}>
            <dt>{keys}</dt>
            <dd>{what}</dd>
          </div>
        ))}
      </dl>
    </div>
  )
}
