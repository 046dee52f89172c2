// The fields of the set-up form for what stands beside the film.
import { useEffect, useRef, useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { faultOf, kCameraWords, lackOf, optionsOf, partsAfter, partsOf, partWords } from './parts'
import type { Parts, PartWords } from './parts'
import type { CameraKind, Film, Offers, Shot } from './shot_api'
import type { ShotDesk } from './use_shot'

interface FieldsProps {
  parts: Parts
  offers: Offers
  film: string
  change: (parts: Parts) => void
}

const kCameras: [CameraKind, string][] = [
  ['still', 'stands still'],
  ['moving', 'moves'],
]

function CameraField({ parts, change }: FieldsProps) {
  return (
    <fieldset>
      <legend>The camera</legend>
      <div class="choice" role="group" aria-label="The camera">
        {kCameras.map(([kind, words]) => (
          <button
            key={kind}
            type="button"
            aria-pressed={parts.camera === kind}
            onClick={() => change({ ...parts, camera: kind })}
          >
            {words}
          </button>
        ))}
      </div>
      <p class="small soft">{kCameraWords[parts.camera]}</p>
    </fieldset>
  )
}

function PartField({ words, parts, offers, film, change }: FieldsProps & { words: PartWords }) {
  const { name, label, none, when } = words
  const options = optionsOf(name, offers, parts.camera, parts[name], film)
  return (
    <div class="shot-part">
      <label>
        <b>{label}</b>
        <select
          value={parts[name]}
          aria-describedby={`part-${name}`}
          onChange={(event) => change({ ...parts, [name]: event.currentTarget.value })}
        >
          <option value="">{none}</option>
          {options.map(({ path, text }) => (
            <option key={path} value={path}>
              {text}
            </option>
          ))}
        </select>
      </label>
      <p id={`part-${name}`} class="small soft">
        {when}
      </p>
    </div>
  )
}

export function PartsFields(props: FieldsProps) {
  const fault = faultOf(props.parts, props.offers)
  const lack = lackOf(props.parts)
  return (
    <>
      <CameraField {...props} />
      {partWords(props.parts.camera).map((words) => (
        <PartField key={words.name} {...props} words={words} />
      ))}
      {(fault || lack) && (
        <p class={`small ${fault ? 'bad' : 'warn'}`} role="status">
          {fault || lack}
        </p>
      )}
      <p class="small soft">
        Files are chosen from the project’s folders: copy them in, such as into <code>films/</code>;
        this page notices. All of it can be changed later.
      </p>
    </>
  )
}

/** Mode 'Set-up': the same of a shot that is there. */
export function PartsForm({ film, offers, desk }: { film: Film; offers: Offers; desk: ShotDesk }) {
  const { tell } = useStudio()
  const saved = partsOf(film)
  const signature = JSON.stringify(saved)
  const [parts, setParts] = useState(saved)
  // What an editor has written, or this form; what was chosen meanwhile is still to be saved.
  const before = useRef(saved)
  useEffect(() => {
    const read = before.current
    before.current = saved
    setParts((chosen) => partsAfter(chosen, read, saved))
  }, [signature])
  const changed = JSON.stringify(parts) !== signature
  return (
    <section class="shot-setup" aria-label="Set-up">
      <form
        class="card shot-form"
        onSubmit={(event) => {
          event.preventDefault()
          const change = ({ shot }: Shot) => {
            const { film: path, fps, shows } = shot!
            return { film: path, fps, shows, ...parts }
          }
          void desk.save(change).then((done) => done && tell('The set-up is saved.'))
        }}
      >
        <PartsFields parts={parts} offers={offers} film={film.film} change={setParts} />
        <div class="row">
          <button
            class="main"
            disabled={!changed || desk.saving || faultOf(parts, offers) !== ''}
          >
            Save the set-up
          </button>
          <button type="button" disabled={!changed} onClick={() => setParts(saved)}>
            As it was
          </button>
        </div>
      </form>
    </section>
  )
}
