// Example projects: made when they are asked for, on this machine.
import { useState } from 'preact/hooks'

import { Bar } from '../../bar'
import { percent, sentence } from '../../words'
import { doorApi } from './door_api'
import type { DoorState, Making } from './door_api'
import { kExamples } from './door_words'

interface ExamplesProps {
  door: DoorState
  ask: (question: Promise<DoorState>) => Promise<DoorState>
  complain: (error: unknown) => void
  open: (folder: string, page?: string) => void
}

const pageOf = (kind: string) => ({ finished: 'run', puppet: 'armature', film: 'shot' })[kind]

function Work({ making, stop }: { making: Making; stop: () => void }) {
  return (
    <>
      <Bar label="Making the example" share={making.share} />
      <p class="soft small number">
        {percent(making.share)} {making.words}
      </p>
      <button onClick={stop}>Stop</button>
    </>
  )
}

function Example(props: ExamplesProps & { kind: string; base: string }) {
  const { door, ask, complain, open, kind, base } = props
  const words = kExamples[kind] ?? { name: kind, about: '', time: '' }
  const folder = `${base.replace(/\/+$/, '')}/${kind}`
  const made = door.projects.find((one) => one.there && one.folder.endsWith(`/${kind}`))
  const there = made?.folder === folder || made?.folder === door.making?.folder ? made : undefined
  const making = door.making?.kind === kind ? door.making : null
  const busy = door.making?.at_work ?? false
  return (
    <li class="door-example">
      <h3>{words.name}</h3>
      <p class="soft small">{words.about}</p>
      {making?.error && making.error !== 'stopped' && (
        <p class="bad small">{sentence(making.error)}</p>
      )}
      <div class="door-example-foot">
        {making?.at_work ? (
          <Work
            making={making}
            stop={() => void ask(doorApi.stopExample()).catch(complain)}
          />
        ) : there ? (
          <button
            class="main"
            aria-label={`Open: ${words.name}`}
            onClick={() => open(there.folder, pageOf(kind))}
          >
            Open
          </button>
        ) : (
          <>
            <button
              disabled={busy || base.trim() === ''}
              aria-label={`Make it: ${words.name}`}
              onClick={() => void ask(doorApi.example(kind, base.trim())).catch(complain)}
            >
              Make it
            </button>
            <span class="soft small">{words.time}</span>
          </>
        )}
      </div>
    </li>
  )
}

export function Examples(props: ExamplesProps) {
  const [base, setBase] = useState(props.door.example_base)
  return (
    <section class="door-examples" aria-label="Examples">
      <div class="row spread">
        <h2>Examples</h2>
        <div class="row">
          <label for="door-base">made in</label>
          <input
            id="door-base"
            class="mono"
            value={base}
            autocomplete="off"
            spellcheck={false}
            onInput={(event) => setBase(event.currentTarget.value)}
          />
        </div>
      </div>
      <p class="soft small">
        Drawn on this machine, without a network. Times are those of two cores with nothing else to
        do.
      </p>
      <ul>
        {props.door.examples.map((kind) => (
          <Example key={kind} {...props} kind={kind} base={base} />
        ))}
      </ul>
    </section>
  )
}
