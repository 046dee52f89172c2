// The placed cameras by name, to look through one of them.
import { useEffect, useRef } from 'preact/hooks'

import type { CameraView } from '../../api'
import { nextByKey } from './keys'

export function CameraList(props: {
  cameras: CameraView[]
  /** '' : the free view */
  current: string
  choose: (name: string) => void
}) {
  const list = useRef<HTMLUListElement>(null)
  useEffect(() => {
    list.current
      ?.querySelector('[aria-current="true"]')
      ?.scrollIntoView({ block: 'nearest' })
  }, [props.current])
  const move = (event: KeyboardEvent) => {
    const buttons = [...list.current!.querySelectorAll('button')]
    const at = buttons.indexOf(event.target as HTMLButtonElement)
    const next = nextByKey(event, buttons.length, at, 1)
    if (next === null) return
    event.preventDefault()
    buttons[next].focus()
  }
  const names = ['', ...props.cameras.map((camera) => camera.name)]
  return (
    <nav class="cameras" aria-label="Cameras">
      <h2 class="label">Look from</h2>
      <ul ref={list} class="list" onKeyDown={move}>
        {names.map((name) => (
          <li key={name}>
            <button
              aria-current={name === props.current ? 'true' : undefined}
              tabIndex={name === props.current ? 0 : -1}
              onClick={() => props.choose(name)}
            >
              <span class="name">{name || 'Free view'}</span>
            </button>
          </li>
        ))}
      </ul>
    </nav>
  )
}
