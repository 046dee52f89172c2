// Photographs that were shot again, and the picks that were made in the older ones.
import type { PhotoFit } from '../../api'
import { count } from '../../words'
import { useStepRun } from './photo_fit_card'
import { isOlder, withOlderHeld } from './photo_model'
import type { PhotoPicking } from './photo_picking'
import { photoPicksOf, withPhotoPicks } from './pick_history'

function ShotAgain({ pose, names }: { pose: string; names: string[] }) {
  const { run, atWork } = useStepRun(`capture/${pose}`, async () => undefined)
  if (names.length === 0) return null
  return (
    <div class="stack">
      <p class="small warn">
        Shot again since they were read: {names.join(', ')}. The page shows the older ones.
      </p>
      <button disabled={atWork} onClick={() => void run()}>
        {atWork ? 'Reading…' : 'Read them again'}
      </button>
    </div>
  )
}

export function OlderPicks({ picking, fit }: { picking: PhotoPicking; fit: PhotoFit | null }) {
  if (!fit) return null
  const { files, pose } = picking
  const sheet = files.history.now
  const picks = photoPicksOf(sheet, pose)
  const older = picks.filter((pick) => isOlder(pick, fit))
  const images = [...new Set(older.map((pick) => pick.image))]
  const again = fit.photographs.filter((one) => one.shot_again).map((one) => one.name)
  const change = (what: string, next: typeof picks) =>
    files.change(what, withPhotoPicks(sheet, pose, next))
  return (
    <>
      <ShotAgain pose={pose} names={again} />
      {older.length > 0 && (
        <div class="stack">
          <p class="small warn">
            {count(older.length, 'pick')} in older photographs of {images.join(', ')}: the fit does
            not use {older.length === 1 ? 'it' : 'them'}. Drag to where the place is now, or:
          </p>
          <div class="row">
            <button onClick={() => change('hold picks', withOlderHeld(picks, fit))}>
              {older.length === 1 ? 'It still holds' : 'They still hold'}
            </button>
            <button
              onClick={() =>
                change(
                  'delete older picks',
                  picks.filter((pick) => !older.includes(pick)),
                )
              }
            >
              Take out
            </button>
          </div>
        </div>
      )}
    </>
  )
}
