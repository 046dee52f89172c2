// A folder without a project: name poses, drop their photographs, make it.
import { useState } from 'preact/hooks'

import { api } from '../api'
import { useStudio } from '../state'
import { bytes, count } from '../words'
import { dropped } from './new_project/files'
import type { Found } from './new_project/files'
import { PerformanceForm } from './new_project/performance_form'
import { PoseCard } from './new_project/pose_card'
import { emptyRow, fewOf, isBlank, missing, spreadOver, withFiles } from './new_project/rows'
import type { Row } from './new_project/rows'
import { Sending } from './new_project/sending'
import { leave, making, send, useUpload } from './new_project/upload'
import './run/run.css'
import './new_project/new_project.css'

function Foot(props: { rows: Row[]; make: () => void }) {
  const used = props.rows.filter((row) => !isBlank(row))
  const photos = used.flatMap((row) => row.photos)
  const size = photos.reduce((sum, photo) => sum + photo.file.size, 0)
  const lacks = missing(props.rows)
  return (
    <footer class="make-foot">
      <p aria-live="polite">
        {lacks ? (
          <span class="soft">{lacks}</span>
        ) : (
          <span class="number">
            {count(used.length, 'pose')}, {count(photos.length, 'photograph')}, {bytes(size)}
          </span>
        )}
      </p>
      <button class="main" disabled={lacks !== ''} onClick={props.make}>
        Make project
      </button>
    </footer>
  )
}

/** The rows, and the changes that the page can make to them. */
function useRows() {
  const [rows, setRows] = useState<Row[]>(() => [emptyRow(), emptyRow()])
  const change = (key: number, next: (row: Row, all: Row[]) => Row) =>
    setRows((old) => old.map((row) => (row.key === key ? next(row, old) : row)))
  return {
    rows,
    rename: (key: number, name: string) => change(key, (row) => ({ ...row, name })),
    add: (key: number, found: Found[]) => change(key, (row, all) => withFiles(row, found, all)),
    clear: (key: number) => change(key, (row) => ({ ...row, photos: [], leftOut: [] })),
    remove: (key: number) => setRows((old) => old.filter((row) => row.key !== key)),
    more: () => setRows((old) => [...old, emptyRow()]),
    spread: (found: Found[]) => setRows((old) => spreadOver(old, found)),
  }
}

async function makeProject(rows: Row[], template: string): Promise<boolean> {
  const names = rows.map((row) => row.name)
  const list = rows.flatMap((row) => row.photos.map((photo) => ({ pose: row.name, photo })))
  await making(() => api.createProject(names, template, fewOf(rows, template)))
  const ended = await send(list)
  return ended.state === 'ended' && ended.failed.length === 0
}

export function NewProjectPage() {
  const { project, reload, tell, complain } = useStudio()
  const upload = useUpload()
  const { rows, rename, add, clear, remove, more, spread } = useRows()
  const [films, setFilms] = useState(false)
  const [chosenTemplate, setTemplate] = useState(rows[0].key)
  const used = rows.filter((row) => !isBlank(row))
  // The first pose in use is the template when the chosen one is gone or empty.
  const chosen = used.find((row) => row.key === chosenTemplate) ?? used[0] ?? rows[0]

  const make = async () => {
    try {
      const whole = await makeProject(used, chosen.name)
      await reload()
      if (!whole) return
      leave()
      location.hash = '#/run'
      tell('The project is made. Press Run, at the top right, to make all its steps.')
    } catch (error) {
      complain(error)
      await reload()
    }
  }
  const drop = (event: DragEvent) => {
    event.preventDefault()
    if (event.dataTransfer && !upload) void dropped(event.dataTransfer).then(spread)
  }
  return (
    <main class="make-page" onDragOver={(event) => event.preventDefault()} onDrop={drop}>
      <div class="make-sheet">
        <header>
          <h1>New project</h1>
          <p class="soft">
            In <code>{project.folder}</code>.{' '}
            {!upload &&
              !films &&
              'One pose for each way the figure stands: drop one folder of photographs on each, ' +
                'or several folders beside them.'}
          </p>
        </header>
        {!upload && (
          <div class="choice" role="group" aria-label="Made of">
            <button aria-pressed={!films} onClick={() => setFilms(false)}>
              Photographs of poses
            </button>
            <button aria-pressed={films} onClick={() => setFilms(true)}>
              Films of an actor
            </button>
          </div>
        )}
        {films ? (
          <PerformanceForm />
        ) : upload ? (
          <Sending upload={upload} />
        ) : (
          <>
            {rows.map((row, i) => (
              <PoseCard
                key={row.key}
                row={row}
                rows={rows}
                number={i + 1}
                template={row === chosen}
                setTemplate={() => setTemplate(row.key)}
                setName={(name) => rename(row.key, name)}
                add={(found) => add(row.key, found)}
                clear={() => clear(row.key)}
                remove={rows.length > 1 ? () => remove(row.key) : null}
              />
            ))}
            <div class="row spread">
              <button onClick={more}>Add a pose</button>
              <p class="soft small">
                The template is the pose that gives the others their net, of mesh and texture: take
                the most open one.
              </p>
            </div>
            <Foot rows={rows} make={() => void make()} />
          </>
        )}
      </div>
    </main>
  )
}
