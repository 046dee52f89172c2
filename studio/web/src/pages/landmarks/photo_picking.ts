// What can be done with picks in photographs: begin a pair on either side, complete it, pick the
// place in further photographs, move, rename, delete.
import { useCallback, useEffect, useState } from 'preact/hooks'

import { api } from '../../api'
import type { PhotoFit, PhotoPick, Pick } from '../../api'
import { useStudio } from '../../state'
import type { Hit } from '../../view/viewer'
import type { PickFiles } from './pick_files'
import {
  namesOf,
  nextName,
  otherUsers,
  photoPairsOf,
  withName,
  withoutPhotoPair,
  withoutPhotoPick,
  withPhotoPick,
  withPick,
} from './pick_history'
import type { PhotoPair } from './pick_history'
import { placeOf, problemsOf, usePickFiles, useSaid } from './picking'
import type { Place } from './picking'

type Pixel = [number, number]

/** One half of a pair; the other is missing, and nothing is saved yet. */
export interface Half {
  name: string
  place?: Place
  pixel?: Pixel
  image?: string
}

/** What the last fit says of the picks; read again when they or the project have changed. */
export function usePhotoFit(pose: string, files: PickFiles): PhotoFit | null {
  const { version, complain } = useStudio()
  const [fit, setFit] = useState<{ pose: string; fit: PhotoFit } | null>(null)
  const revision = files.revision(pose)
  useEffect(() => {
    let wanted = true
    api.photoFit(pose).then(
      (answer) => wanted && setFit({ pose, fit: answer }),
      (error: unknown) => wanted && complain(error),
    )
    return () => {
      wanted = false
    }
  }, [pose, version, revision, complain])
  return fit?.pose === pose ? fit.fit : null
}

/** Pairs that begin on one side and are completed on the other. */
function usePairing(
  files: PickFiles,
  template: string,
  pose: string,
  image: string,
  open: PhotoPair | null,
  choose: (name: string) => void,
) {
  const { tell } = useStudio()
  const sheet = files.history.now
  const [pending, setPending] = useState<Half | null>(null)
  const [typed, setTyped] = useState('')
  const auto = nextName(namesOf(sheet))

  const begin = (part: Omit<Half, 'name'>) => {
    const wanted = typed.trim()
    const free = wanted !== '' && !namesOf(sheet).has(wanted)
    if (wanted !== '' && !free) tell(`'${wanted}' is taken; this landmark is called ${auto}.`)
    choose('')
    setPending({ name: free ? wanted : auto, ...part })
  }
  const put = (what: string, name: string, place: Place | null, pixel: PhotoPick | null) => {
    let next = sheet
    if (place) next = withPick(next, template, { ...place, name } as Pick)
    if (pixel) next = withPhotoPick(next, pose, pixel)
    files.change(`${what} ${name}`, next)
  }
  const advance = (half: Half) => {
    const { name, place, pixel } = half
    if (!place || !pixel || !half.image) return setPending(half)
    setPending(null)
    setTyped('')
    choose(name)
    put('pair', name, place, { name, image: half.image, pixel })
  }
  const pickPlace = (hit: Hit) => {
    const place = placeOf(hit)
    if (pending) advance({ ...pending, place })
    else if (open && !open.template) put('place', open.name, place, null)
    else begin({ place })
  }
  const pickPixel = (pixel: Pixel) => {
    if (pending) advance({ ...pending, pixel, image })
    else if (open && !open.pixels.some((one) => one.image === image))
      put('pick', open.name, null, { name: open.name, image, pixel })
    else begin({ pixel, image })
  }
  const movePlace = (name: string, hit: Hit) => {
    if (pending?.name === name) setPending({ ...pending, place: placeOf(hit) })
    else put('move', name, placeOf(hit), null)
  }
  const movePixel = (name: string, pixel: Pixel) => {
    if (pending?.name === name) setPending({ ...pending, pixel })
    else put('move', name, null, { name, image, pixel })
  }
  return { pending, setPending, typed, setTyped, auto, pickPlace, pickPixel, movePlace, movePixel }
}

export type PhotoPicking = ReturnType<typeof usePhotoPicking>

/** @param image  the photograph that is shown */
export function usePhotoPicking(template: string, pose: string, image: string) {
  const { tell, complain } = useStudio()
  const files = usePickFiles()
  const sheet = files.history.now
  const pairs = photoPairsOf(sheet, template, pose)
  const [chosen, setChosen] = useState('')
  const [renaming, setRenaming] = useState('')
  const [said, setSaid] = useSaid()
  const at = pairs.findIndex((pair) => pair.name === chosen)
  const pair = pairs[at] ?? null
  const pairing = usePairing(files, template, pose, image, pair, setChosen)
  const { pending, setPending } = pairing
  useEffect(() => setSaid(''), [chosen, pending, image])
  useEffect(() => {
    setPending(null)
    setRenaming('')
    setChosen('')
  }, [pose])

  const rename = (from: string, to: string) => {
    setRenaming('')
    const name = to.trim()
    if (name === '' || name === from) return
    if (namesOf(sheet).has(name)) return complain(`A landmark is already called '${name}'.`)
    files.change(`rename ${from}`, withName(sheet, from, name))
    setChosen(name)
  }
  const remove = (name = chosen) => {
    const users = otherUsers(sheet, template, pose, name)
    const gone = pairs.find((one) => one.name === name)
    if (!gone) return
    const verb = users.length === 1 ? 'uses' : 'use'
    if (users.length > 0)
      tell(`${name} stays on ${template}: ${users.join(', ')} also ${verb} it.`)
    if (users.length > 0 && gone.pixels.length === 0) return
    files.change(`delete ${name}`, withoutPhotoPair(sheet, template, pose, name))
    if (users.length === 0) setChosen('')
  }
  const step = (by: number) => {
    const from = at < 0 && by < 0 ? pairs.length : at
    const next = pairs[Math.min(pairs.length - 1, Math.max(0, from + by))]
    if (next) setChosen(next.name)
  }
  const cancel = useCallback(() => {
    setPending(null)
    setChosen('')
  }, [])
  return {
    ...pairing,
    files,
    template,
    pose,
    pairs,
    pair,
    chosen,
    choose: setChosen,
    renaming,
    setRenaming,
    rename,
    remove,
    removePixel: (name: string, from: string) =>
      files.change(`delete ${name} in ${from}`, withoutPhotoPick(sheet, pose, name, from)),
    step,
    cancel,
    said,
    problems: problemsOf(files, [template, pose]),
    undo: () => {
      if (pending) return setPending(null)
      const what = files.undo()
      if (what) setSaid(`Undone: ${what}.`)
    },
    redo: () => {
      const what = files.redo()
      if (what) setSaid(`Done again: ${what}.`)
    },
  }
}
