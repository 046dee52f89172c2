// Which formats the animation is handed over in, and the run that makes them.
import { useState } from 'preact/hooks'

import { api, ApiError } from '../../api'
import type { Stage, Step } from '../../api'
import { useStudio } from '../../state'
import { bytes, percent } from '../../words'
import { useSetOption } from '../run/option_form'
import { OptionRow } from '../run/option_row'
import { FilmButton } from './film_dialog'
import { askedBy, formatsOf, noteWords, otherOptions } from './formats'
import type { Format, Note, Result } from './formats'
import { useNotes } from './notes'

function FormatLine(props: {
  format: Format
  /** null: not written by the last export */
  note: Note | null
  wanted: boolean
  toggle: () => void
}) {
  const { format, note, wanted } = props
  const said = note ? noteWords(note) : ''
  const id = `format-${format.id}`
  return (
    <li class={wanted ? 'on' : ''}>
      <input
        id={id}
        type="checkbox"
        checked={wanted}
        aria-describedby={`${id}-use`}
        onChange={props.toggle}
      />
      <label for={id}>
        <b>{format.title}</b>
        <span class="number">{note ? bytes(note.bytes) : ''}</span>
        <small id={`${id}-use`}>
          {format.use}
          {said && <span class="said number">{said}</span>}
        </small>
      </label>
    </li>
  )
}

async function setFormats(step: Step, value: string | null): Promise<void> {
  if (value === null) return
  const { revision } = await api.project()
  await api.setOption({ step: step.step, pose: '', option: 'formats', value, revision })
}

function MoreOptions({ step, stage }: { step: Step; stage: Stage }) {
  const setOption = useSetOption()
  const [busy, setBusy] = useState(false)
  const save = async (option: string, value: string | null) => {
    setBusy(true)
    const done = await setOption({ step: step.step, pose: '', option, value })
    setBusy(false)
    return done
  }
  const others = otherOptions(stage)
  if (others.length === 0) return null
  return (
    <details class="run-options">
      <summary>{others.length} options of the export</summary>
      <ul>
        {others.map((option) => (
          <OptionRow
            key={option.name}
            state={{
              option,
              value: step.options[option.name] ?? option.default,
              set: step.set[option.name] ?? null,
            }}
            disabled={busy}
            save={(value) => save(option.name, value)}
          />
        ))}
      </ul>
    </details>
  )
}

function StateOfExport({ step, changed }: { step: Step; changed: boolean }) {
  const { steps, running } = useStudio()
  const work = running?.steps[step.id]
  if (work)
    return (
      <p>
        Exports, <span class="number">{percent(work.fraction)}</span>: {work.what}
      </p>
    )
  if (running) return <p class="soft">A run is at work.</p>
  if (steps.locked_by) return <p class="warn">{steps.locked_by}</p>
  if (step.state === 'failed') return <p class="bad">The last export failed: {step.error}</p>
  if (changed || step.seconds === 0)
    return <p class="soft">Export writes the formats that are checked.</p>
  if (step.state === 'done') return <p class="good">The files are up to date.</p>
  return <p class="soft">The animation has changed since: export writes it again.</p>
}

export function Formats(props: { step: Step; stage: Stage; results: Result[] }) {
  const { steps, running, reload, complain } = useStudio()
  const { step, stage } = props
  const notes = useNotes(props.results)
  const formats = formatsOf(stage, step)
  const [toggled, setToggled] = useState<Set<string>>(new Set())
  const [busy, setBusy] = useState(false)
  const isWanted = (one: Format) => one.on !== toggled.has(one.id)
  const wanted = new Set(formats.filter(isWanted).map((one) => one.id))
  const asked = askedBy(formats, wanted)

  const toggle = (id: string) => {
    const next = new Set(toggled)
    if (!next.delete(id)) next.add(id)
    setToggled(next)
  }
  const start = async () => {
    setBusy(true)
    try {
      await setFormats(step, asked)
      setToggled(new Set())
      await api.run({ until: [step.id] })
    } catch (error) {
      complain(error)
      // 409: pipeline.yaml or the lock is another's by now; the page shows what is.
      if (error instanceof ApiError && error.status !== 409) setToggled(new Set())
    }
    await reload()
    setBusy(false)
  }
  const nothing = asked === null && step.state === 'done'
  const blocked = busy || running !== null || steps.locked_by !== '' || wanted.size === 0
  return (
    <section class="export-formats" aria-label="Formats">
      <h2>Animation</h2>
      <ul>
        {formats.map((format) => (
          <FormatLine
            key={format.id}
            format={format}
            note={notes.find((one) => one.format === format.id) ?? null}
            wanted={wanted.has(format.id)}
            toggle={() => toggle(format.id)}
          />
        ))}
      </ul>
      <FilmButton step={step} />
      <MoreOptions step={step} stage={stage} />
      <div class="go">
        <button class={nothing ? '' : 'main'} disabled={blocked || nothing} onClick={start}>
          Export
        </button>
        <div aria-live="polite">
          {wanted.size === 0 ? (
            <p class="warn">Check one format at least.</p>
          ) : (
            <StateOfExport step={step} changed={asked !== null} />
          )}
        </div>
      </div>
    </section>
  )
}
