// Photographs of a pose, or cameras of a shot, in one row, to go from one to the next.
import { useEffect, useRef } from 'preact/hooks'

import { Picture } from '../../picture'
import { nextByKey } from './keys'

export function Strip(props: {
  /** the small picture of a name */
  src: (name: string) => string
  label: string
  names: string[]
  current: string
  choose: (name: string) => void
  /** a short word on a photograph, over its picture */
  note?: (name: string) => string
}) {
  const list = useRef<HTMLUListElement>(null)
  useEffect(() => {
    const button = list.current?.querySelector('[aria-current="true"]')
    button?.scrollIntoView({ block: 'nearest', inline: 'center' })
  }, [props.current])
  const move = (event: KeyboardEvent) => {
    const buttons = [...list.current!.querySelectorAll('button')]
    const next = nextByKey(event, buttons.length, buttons.indexOf(event.target as never), 1)
    if (next === null) return
    event.preventDefault()
    buttons[next].focus()
  }
  return (
    <nav class="strip" aria-label={props.label}>
      <ul ref={list} onKeyDown={move}>
        {props.names.map((name, i) => (
          <li key={name}>
            <button
              aria-current={name === props.current ? 'true' : undefined}
              tabIndex={name === props.current || (!props.current && i === 0) ? 0 : -1}
              title={name}
              onClick={() => props.choose(name)}
            >
              <Picture src={props.src(name)} alt="" loading="lazy" />
              <span>{name}</span>
              {props.note?.(name) && <em>{props.note(name)}</em>}
            </button>
          </li>
        ))}
      </ul>
    </nav>
  )
}
