// A new performance: the films of each camera, and how the cameras stand, if that is known.
import { useState } from 'preact/hooks'

import { api } from '../../api'
import { useStudio } from '../../state'
import { DropFiles, Faults, SendingBar, useSending } from '../../uploads/send_files'
import { itemsFor } from '../../uploads/upload_model'
import type { Item } from '../../uploads/upload_model'
import { bytes, count } from '../../words'
import { camerasOf, isBeside } from './cameras_of'
import { asName } from './rows'
import { leave, making } from './upload'

export function PerformanceForm() {
  const { reload, tell, complain } = useStudio()
  const [name, setName] = useState('walk')
  const [items, setItems] = useState<Item[]>([])
  const [calibration, setCalibration] = useState<File | null>(null)
  const [leftOut, setLeftOut] = useState<string[]>([])
  const [paint, setPaint] = useState(false)
  const [bend, setBend] = useState(false)
  const { sending, failed, send, stop } = useSending('shot')
  const rig = useSending('calibration')
  const shot = asName(name)
  const lines = camerasOf(items)
  const cameras = lines.filter((one) => !isBeside(one.name))
  const lacks =
    shot === '' ? 'Name the shot.' : cameras.length < 2 ? 'Films of two cameras or more.' : ''
  const size = items.reduce((sum, one) => sum + one.file.size, 0)

  const make = async () => {
    try {
      await making(() => api.createPerformance([shot], paint, bend))
      const arrived = await send(items, [], shot)
      if (calibration) await rig.send([{ file: calibration, name: calibration.name }])
      leave()
      await reload()
      location.hash = calibration ? '#/films' : '#/cameras'
      if (arrived.length === items.length)
        tell(
          calibration
            ? 'The project is made. Press Run, at the top right, to find the motion.'
            : 'The project is made. Now the cameras: where did each stand?',
        )
    } catch (error) {
      leave()
      complain(error)
      await reload()
    }
  }
  if (sending ?? rig.sending)
    return <SendingBar sending={(sending ?? rig.sending)!} stop={stop} />
  return (
    <form
      class="make-films"
      onSubmit={(event) => {
        event.preventDefault()
        if (!lacks) void make()
      }}
    >
      <label class="stack">
        <b>The shot’s name</b>
        <input
          value={name}
          spellcheck={false}
          autocomplete="off"
          onInput={(event) => setName(event.currentTarget.value)}
        />
      </label>
      <DropFiles
        place="shot"
        folder
        words="Drop the films here: a video of each camera, or its folder of numbered pictures."
        add={(found) => {
          const told = itemsFor('shot', found)
          const names = new Set(told.items.map((one) => one.name))
          setItems((old) => [...old.filter((one) => !names.has(one.name)), ...told.items])
          setLeftOut(told.leftOut)
        }}
      >
        {lines.length > 0 && (
          <ul class="make-cameras">
            {lines.map((one) => (
              <li key={one.name}>
                <code>{one.words}</code>
              </li>
            ))}
          </ul>
        )}
        {leftOut.length > 0 && (
          <p class="small warn">
            {count(leftOut.length, 'file')} left out, no film: {leftOut[0]}
          </p>
        )}
      </DropFiles>
      <label class="stack">
        <b>Where the cameras stand</b>
        <input
          type="file"
          accept=".yml,.yaml,.json,.txt,.toml,.xml,.csv"
          onChange={(event) => setCalibration(event.currentTarget.files?.[0] ?? null)}
        />
        <span class="small soft">
          A calibration of OpenCV, Qualisys, anipose or COLMAP. Without one, the page Cameras makes
          it from points that you click.
        </span>
      </label>
      <label class="make-check">
        <input type="checkbox" checked={paint} onChange={() => setPaint(!paint)} />
        Paint what moves from the films
      </label>
      <label class="make-check">
        <input type="checkbox" checked={bend} onChange={() => setBend(!bend)} />
        Bend what moves into the films, frame by frame
      </label>
      <p class="small soft">Both are for the actor’s own body or scan, not for a puppet.</p>
      <Faults failed={[...failed, ...rig.failed]} />
      <footer class="make-foot">
        <p aria-live="polite" class={lacks ? 'soft' : 'number'}>
          {lacks || `${count(cameras.length, 'camera')}, ${bytes(size)}`}
        </p>
        <button class="main" disabled={lacks !== ''}>
          Make project
        </button>
      </footer>
    </form>
  )
}
