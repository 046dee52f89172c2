// What a project needs now and then: room on the disk, a look over its files, one file of it all,
// its cameras for other programs, what is installed.
import { useState } from 'preact/hooks'

import { send } from '../../api'
import { useStudio } from '../../state'
import './upkeep.css'

interface Done {
  said: string
  good: boolean
  /** a folder of the project that was written, or '' */
  made: string
}

const kWays: { what: string; name: string; title: string }[] = [
  { what: 'gc-look', name: 'Free space…', title: 'What earlier runs left that nothing needs' },
  { what: 'verify', name: 'Check all files', title: 'Reads all results, and removes damaged ones' },
  { what: 'pack', name: 'Pack', title: 'The whole project as one file, with its results' },
  { what: 'pack-small', name: 'Pack small', title: 'Without results; they run once again' },
  { what: 'doctor', name: 'Programs', title: 'Versions, the free disk, and what is missing' },
]
const kCameras = [
  { to: 'colmap', name: 'COLMAP, splats' },
  { to: 'transforms', name: 'nerfstudio' },
  { to: 'metashape', name: 'Metashape' },
]

export function Upkeep() {
  const { project, steps, running, reload, complain } = useStudio()
  const [busy, setBusy] = useState('')
  const [done, setDone] = useState<(Done & { what: string }) | null>(null)
  const [to, setTo] = useState('colmap')
  const placed = project.poses.filter((pose) => pose.has_cameras)
  const [wanted, setWanted] = useState('')
  const pose = placed.find((one) => one.name === wanted) ?? placed[0]
  const act = async (what: string, more: object = {}) => {
    setBusy(what)
    setDone(null)
    await send<Done>('POST', '/api/upkeep', { what, ...more }).then(
      (told) => setDone({ ...told, what }),
      complain,
    )
    setBusy('')
    await reload()
  }
  const blocked = busy !== '' || running !== null
  return (
    <details class="upkeep">
      <summary>Project: pack, free space, check</summary>
      <div class="stack">
        <div class="row">
          {kWays.map((way) => (
            <button
              key={way.what}
              title={way.title}
              disabled={blocked}
              onClick={() => void act(way.what)}
            >
              {way.name}
            </button>
          ))}
          {steps.locked_by !== '' && (
            <button
              title={`${steps.locked_by}. Only where that machine or program is gone.`}
              disabled={blocked}
              onClick={() => void act('unlock')}
            >
              Take its lock away
            </button>
          )}
        </div>
        {pose && project.kind === 'poses' && (
          <form
            class="row"
            onSubmit={(event) => {
              event.preventDefault()
              void act('cameras', { to, pose: pose.name })
            }}
          >
            <label class="small" for="upkeep-to">
              Cameras of
            </label>
            <select
              aria-label="Pose"
              value={pose.name}
              onChange={(event) => setWanted(event.currentTarget.value)}
            >
              {placed.map((one) => (
                <option key={one.name}>{one.name}</option>
              ))}
            </select>
            <select
              id="upkeep-to"
              aria-label="Program"
              value={to}
              onChange={(event) => setTo(event.currentTarget.value)}
            >
              {kCameras.map((one) => (
                <option key={one.to} value={one.to}>
                  for {one.name}
                </option>
              ))}
            </select>
            <button disabled={blocked}>Write them</button>
          </form>
        )}
        <div aria-live="polite" class="stack">
          {busy && <p class="soft small">At work …</p>}
          {done && (
            <>
              <pre class={`upkeep-said ${done.good ? '' : 'bad'}`} tabIndex={0}>
                {done.said.trim()}
              </pre>
              {done.what === 'gc-look' && (
                <button disabled={blocked} onClick={() => void act('gc')}>
                  Remove these
                </button>
              )}
              {done.what.startsWith('pack') && (
                <a class="button main" href="/api/upkeep/packed" download={`${project.name}.zip`}>
                  Take the file
                </a>
              )}
              {done.made && (
                <p class="small">
                  In the project’s folder <code>{done.made}</code>.
                </p>
              )}
            </>
          )}
        </div>
      </div>
    </details>
  )
}
