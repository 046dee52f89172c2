// A project without a film: which folder it is in, which frames show which pose, and what stands
// beside the film.
import { useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { SendFiles } from '../../uploads/send_files'
import { isFilm } from '../../uploads/upload_model'
import { count } from '../../words'
import { faultOf, kNoParts } from './parts'
import { PartsFields } from './parts_fields'
import { shotApi } from './shot_api'
import type { Shot, Show } from './shot_api'
import type { ShotDesk } from './use_shot'

/** The first poses, evenly over the film: a start that is easily corrected on the strip. */
export function firstShows(poses: string[], pictures: number): Show[] {
  const shown = poses.length > 1 ? poses.slice(0, Math.max(2, pictures)) : [poses[0], poses[0]]
  const last = Math.max(1, pictures - 1)
  return shown.map((pose, i) => ({ frame: Math.round((i * last) / (shown.length - 1)), pose }))
}

/** Sends a film; a video is cut into the numbered pictures that a shot is made of. */
function SendFilm({ cut }: { cut: (fps: number) => void }) {
  const { reload, complain } = useStudio()
  const [cuts, setCuts] = useState('')
  const done = async (paths: string[]) => {
    try {
      for (const video of paths.filter(isFilm)) {
        setCuts(video)
        cut((await shotApi.cut(video)).fps)
      }
    } catch (error) {
      complain(error)
    }
    setCuts('')
    await reload()
  }
  if (cuts) return <p role="status">Cuts {cuts} into its pictures …</p>
  return (
    <SendFiles
      place="film"
      folder
      words="Drop the film: a video, or its folder of numbered pictures."
      done={(paths) => void done(paths)}
    />
  )
}

export function SetupForm({ shot, desk }: { shot: Shot; desk: ShotDesk }) {
  const { project } = useStudio()
  const poses = project.poses.map((pose) => pose.name)
  const [chosen, setChosen] = useState('')
  const [fps, setFps] = useState('12')
  const [parts, setParts] = useState(kNoParts)
  const { folders } = shot.offers
  const folder = folders.find((one) => one.path === chosen) ?? folders[0]
  const number = Number(fps)
  const fits = number > 0 && Number.isInteger(Math.round((1e6 * project.fps) / number) / 1e6)
  return (
    <main class="empty shot-new">
      <h1>Put the character into a filmed shot</h1>
      <p>
        Film the animated figure, photograph some of its poses on the turntable, and Keypose makes
        the pictures between.
      </p>
      {!folder ? (
        <SendFilm cut={(rate) => rate > 0 && setFps(String(rate))} />
      ) : (
        <form
          class="card shot-form"
          onSubmit={(event) => {
            event.preventDefault()
            const shows = firstShows(poses, folder.pictures)
            void desk.save(() => ({ film: folder.path, fps: number, shows, ...parts }))
          }}
        >
          <label>
            <b>Folder of the film</b>
            <select
              value={folder.path}
              onChange={(event) => setChosen(event.currentTarget.value)}
            >
              {folders.map((one) => (
                <option key={one.path} value={one.path}>
                  {one.path} · {count(one.pictures, 'picture')}
                </option>
              ))}
            </select>
          </label>
          <label>
            <b>Filmed pictures a second</b>
            <input
              inputMode="decimal"
              value={fps}
              onInput={(event) => setFps(event.currentTarget.value)}
            />
          </label>
          <details>
            <summary>Moving camera, empty set, mattes, props</summary>
            <div class="shot-fields">
              <PartsFields
                parts={parts}
                offers={shot.offers}
                film={folder.path}
                change={setParts}
              />
            </div>
          </details>
          <p class="small">
            {fits
              ? 'Next you say which frames show which pose.'
              : `The project has ${project.fps} pictures a second, which must be a multiple.`}
          </p>
          <details>
            <summary>Another film</summary>
            <SendFilm cut={(rate) => rate > 0 && setFps(String(rate))} />
          </details>
          <button class="main" disabled={!fits || desk.saving || faultOf(parts, shot.offers) !== ''}>
            Add the film
          </button>
        </form>
      )}
    </main>
  )
}
