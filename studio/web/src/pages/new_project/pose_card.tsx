// One pose of the new project: its name, its photographs, and where to drop them.
import { useEffect, useMemo, useState } from 'preact/hooks'

import { bytes, count } from '../../words'
import { Chooser } from './chooser'
import { dropped, isDrawn, kindOf } from './files'
import type { Found, LeftOut, Photo } from './files'
import { kScan, nameProblem } from './rows'
import type { Row } from './rows'

const kThumbnails = 5
/**
 * Fewer are refused by the step capture: of a scan, and of a pose that the template is bent into.
 */
const kFewest = 8
const kFewestFitted = 2

/** A few photographs, spread over all, so that a wrong folder shows at once. */
function samplesOf(photos: Photo[]): Photo[] {
  if (photos.length <= kThumbnails) return photos
  const at = (i: number) => Math.round((i * (photos.length - 1)) / (kThumbnails - 1))
  return Array.from({ length: kThumbnails }, (_, i) => photos[at(i)])
}

function Thumbnail({ photo }: { photo: Photo }) {
  const url = useMemo(() => URL.createObjectURL(photo.file), [photo.file])
  const [broken, setBroken] = useState(!isDrawn(photo.name))
  useEffect(() => () => URL.revokeObjectURL(url), [url])
  if (broken)
    return (
      <span class="tile" title={photo.name}>
        {kindOf(photo.name)}
      </span>
    )
  return <img src={url} alt={photo.name} title={photo.name} onError={() => setBroken(true)} />
}

export function LeftOutList({ files }: { files: LeftOut[] }) {
  if (files.length === 0) return null
  return (
    <details class="make-left">
      <summary class="warn">{count(files.length, 'file')} left out</summary>
      <ul>
        {files.map((one, i) => (
          <li key={i}>
            <code>{one.path}</code> {one.why}
          </li>
        ))}
      </ul>
    </details>
  )
}

/** What becomes of a pose of few photographs. */
function FewWords({ photos, template }: { photos: number; template: boolean }) {
  if (template)
    return photos < kFewest ? (
      <p class="warn small">The pose that gives its net needs {kFewest} photographs; 24 or more are better.</p>
    ) : null
  if (photos < kFewestFitted)
    return <p class="warn small">A pose needs {kFewestFitted} photographs; 6 are better.</p>
  if (photos >= kScan) return null
  return (
    <p class="small soft">
      The pose that gives its net will be bent into them; {kScan} or more all round make a scan of their own.
    </p>
  )
}

function Photographs(props: { row: Row; template: boolean; clear: () => void }) {
  const { row, clear } = props
  const size = row.photos.reduce((sum, photo) => sum + photo.file.size, 0)
  return (
    <div class="photos">
      <div class="strip">
        {samplesOf(row.photos).map((photo) => (
          <Thumbnail key={photo.name} photo={photo} />
        ))}
      </div>
      <p>
        <b class="number">{count(row.photos.length, 'photograph')}</b>{' '}
        <span class="soft number">{bytes(size)}</span>{' '}
        <button class="link" onClick={clear} aria-label={`take them out: ${row.name}`}>
          take them out
        </button>
      </p>
      <FewWords photos={row.photos.length} template={props.template} />
    </div>
  )
}

export function PoseCard(props: {
  row: Row
  rows: Row[]
  number: number
  template: boolean
  setTemplate: () => void
  setName: (name: string) => void
  add: (found: Found[]) => void
  clear: () => void
  remove: (() => void) | null
}) {
  const { row, number } = props
  const [over, setOver] = useState(false)
  const problem = nameProblem(row, props.rows)
  const called = row.name || `pose ${number}`
  const id = `pose-${row.key}`
  const drop = (event: DragEvent) => {
    event.preventDefault()
    event.stopPropagation() // the page would make poses of the folders
    setOver(false)
    if (event.dataTransfer) void dropped(event.dataTransfer).then(props.add)
  }
  return (
    <section class="make-pose" aria-label={`Pose ${number}: ${row.name || 'no name yet'}`}>
      <div class="facts">
        <label for={id}>Pose {number}</label>
        <input
          id={id}
          class="name"
          value={row.name}
          placeholder={number === 1 ? 'rest' : 'name'}
          spellcheck={false}
          autocomplete="off"
          aria-invalid={problem !== ''}
          aria-describedby={`${id}-problem`}
          onInput={(event) => props.setName(event.currentTarget.value.normalize('NFC'))}
        />
        <p id={`${id}-problem`} class="bad small" role="alert">
          {problem}
        </p>
        <label class="template">
          <input
            type="radio"
            name="template"
            checked={props.template}
            onChange={props.setTemplate}
          />
          gives the others their net (template)
        </label>
        {props.remove && (
          <button class="quiet" onClick={props.remove} aria-label={`Remove ${called}`}>
            Remove
          </button>
        )}
      </div>
      <div
        class={`drop ${over ? 'over' : ''} ${row.photos.length > 0 ? 'full' : ''}`}
        onDragOver={(event) => {
          event.preventDefault()
          setOver(true)
        }}
        onDragLeave={() => setOver(false)}
        onDrop={drop}
      >
        {row.photos.length > 0 ? (
          <Photographs row={row} template={props.template} clear={props.clear} />
        ) : (
          <p class="soft">Drop this pose’s folder of photographs here</p>
        )}
        <div class="row">
          <Chooser
            folder
            words="Choose a folder"
            label={`Choose a folder for ${called}`}
            add={props.add}
          />
          <Chooser
            folder={false}
            words="Choose files"
            label={`Choose files for ${called}`}
            add={props.add}
          />
        </div>
        <LeftOutList files={row.leftOut} />
      </div>
    </section>
  )
}
