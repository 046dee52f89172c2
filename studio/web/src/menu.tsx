// A menu that opens at a place of the window, by a button, a right click or the menu key.
import { useEffect, useRef } from 'preact/hooks'

export interface MenuItem {
  words: string
  /** the key that does the same, or '' */
  keys?: string
  act: () => void
  disabled?: boolean
}

export interface MenuPlace {
  /** in the window [px] */
  x: number
  y: number
}

/** Where a menu opens: at the mouse, or below what has the focus. */
export function placeOfMenu(event: MouseEvent): MenuPlace {
  if (event.type === 'contextmenu' && (event.clientX > 0 || event.clientY > 0))
    return { x: event.clientX, y: event.clientY }
  const box = (event.currentTarget as Element).getBoundingClientRect()
  return { x: box.left, y: box.bottom }
}

const kMargin = 8

export function Menu(props: {
  label: string
  items: MenuItem[]
  place: MenuPlace
  /** what to know before anything of it is done */
  note?: string
  close: () => void
}) {
  const { items, place, close } = props
  const menu = useRef<HTMLDivElement>(null)
  useEffect(() => {
    const before = document.activeElement
    const own = menu.current!
    // Within the window, whatever the mouse's place.
    const { width, height } = own.getBoundingClientRect()
    own.style.left = `${Math.max(kMargin, Math.min(place.x, innerWidth - width - kMargin))}px`
    own.style.top = `${Math.max(kMargin, Math.min(place.y, innerHeight - height - kMargin))}px`
    own.querySelector<HTMLButtonElement>('button:not(:disabled)')?.focus()
    const outside = (event: Event) => {
      if (!own.contains(event.target as Node)) close()
    }
    addEventListener('pointerdown', outside, { capture: true })
    addEventListener('wheel', outside, { capture: true, passive: true })
    return () => {
      removeEventListener('pointerdown', outside, { capture: true })
      removeEventListener('wheel', outside, { capture: true })
      if (before instanceof HTMLElement && before.isConnected && own.contains(document.activeElement))
        before.focus()
    }
  }, [])
  const key = (event: KeyboardEvent) => {
    event.stopPropagation()
    if (event.key === 'Escape' || event.key === 'Tab') {
      event.preventDefault()
      return close()
    }
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key] ?? 0
    if (by === 0) return
    event.preventDefault()
    const all = [...menu.current!.querySelectorAll<HTMLButtonElement>('button:not(:disabled)')]
    const at = all.indexOf(document.activeElement as HTMLButtonElement)
    all[(at + by + all.length) % all.length]?.focus()
  }
  return (
    <div ref={menu} class="menu" onKeyDown={key} onContextMenu={(event) => event.preventDefault()}>
      <div role="menu" aria-label={props.label}>
        {items.map((item) => (
          <button
            key={item.words}
            class="quiet"
            role="menuitem"
            disabled={item.disabled}
            onClick={() => {
              close()
              item.act()
            }}
          >
            <span>{item.words}</span>
            {item.keys && <kbd>{item.keys}</kbd>}
          </button>
        ))}
      </div>
      {props.note && <p class="small soft">{props.note}</p>}
    </div>
  )
}
