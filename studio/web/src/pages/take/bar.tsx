// Play, ones and twos, undo, and keeping the changes as a new take.
import { useEffect, useRef, useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { armatureApi } from '../armature/armature_api'
import { addressOfTake } from '../armature/setup'
import type { Player } from '../timeline/player'
import { Counter, HelpButton, History, PlayButtons, Zoom } from '../timeline/transport'
import type { Zooming } from '../timeline/use_view_window'
import { setStep } from './acts'
import type { TakeDesk } from './desk'
import { takeApi } from './take_api'
import { filmLength, nextName } from './take_model'
import type { Between } from './take_model'

function Steps({ desk }: { desk: TakeDesk }) {
  return (
    <div class="choice" role="group" aria-label="Frames that each recorded one is shown">
      {['Ones', 'Twos', 'Threes', 'Fours'].map((name, i) => (
        <button
          key={name}
          aria-pressed={desk.take.step === i + 1}
          onClick={() => setStep(desk, i + 1)}
        >
          {name}
        </button>
      ))}
    </div>
  )
}

const kPlayed: [Between, string, string][] = [
  ['hold', 'Held', 'Each recorded frame stands until the next: hard stops'],
  ['linear', 'Even', 'From each recorded frame to the next at even pace'],
  ['smooth', 'Smooth', 'Smooth curves through the recorded frames'],
]

/** What is played is what Bake makes. */
function Betweens({ desk }: { desk: TakeDesk }) {
  const { edits } = desk
  return (
    <div class="choice" role="group" aria-label="Played and baked between recorded frames">
      {kPlayed.map(([between, name, title]) => (
        <button
          key={between}
          aria-pressed={edits.between === between}
          title={`${title}, ${desk.take.fps} pictures a second (B)`}
          onClick={() => edits.play(between)}
        >
          {name}
        </button>
      ))}
    </div>
  )
}

const isName = (name: string) => /^[\p{L}\p{M}\p{N}_][\p{L}\p{M}\p{N}_-]*$/u.test(name)

/** Asks for the new take's name, and goes to it. */
function SaveForm({ desk, close }: { desk: TakeDesk; close: () => void }) {
  const { complain, tell } = useStudio()
  const [name, setName] = useState('')
  const [names, setNames] = useState<string[]>([])
  const [busy, setBusy] = useState(false)
  const field = useRef<HTMLInputElement>(null)
  useEffect(() => {
    field.current?.focus()
    armatureApi
      .story()
      .then((story) => {
        const all = [...story.takes, ...story.edited]
        setNames(all)
        setName((old) => old || nextName(desk.name, all))
      })
      .catch(complain)
  }, [desk.name, complain])
  const taken = names.includes(name)
  const problem = taken ? `There is a take ${name} already.` : ''
  const save = async () => {
    setBusy(true)
    const saved = desk.edits.done
    try {
      await takeApi.save(desk.name, name, saved.flat())
      if (desk.edits.saved(saved)) {
        tell(`${name} is saved; ${desk.name} stays as it was.`)
        location.hash = addressOfTake(name)
        return
      }
      tell(`${name} is saved, without what was changed meanwhile; that is still to be saved.`)
      setNames((old) => [...old, name])
      setName(nextName(desk.name, [...names, name]))
    } catch (error) {
      complain(error)
    }
    setBusy(false)
  }
  return (
    <form
      class="take-save"
      onSubmit={(event) => {
        event.preventDefault()
        if (isName(name) && !taken && !busy) void save()
      }}
      onKeyDown={(event) => {
        if (event.key !== 'Escape') return
        event.preventDefault()
        close()
      }}
    >
      <label for="take-name">New take</label>
      <div class="row">
        <input
          id="take-name"
          ref={field}
          value={name}
          autocomplete="off"
          spellcheck={false}
          aria-invalid={taken}
          aria-describedby="take-name-hint"
          onInput={(event) => setName(event.currentTarget.value.normalize('NFC'))}
        />
        <button class="main" disabled={!isName(name) || taken || busy}>
          {busy ? 'Saves …' : 'Save'}
        </button>
        <button type="button" class="quiet" onClick={close}>
          Cancel
        </button>
      </div>
      <p id="take-name-hint" class={`small ${problem ? 'bad' : 'soft'}`}>
        {problem || `armature/${name || '…'}; ${desk.name} stays as it was.`}
      </p>
    </form>
  )
}

export function TakeBar(props: {
  desk: TakeDesk
  player: Player
  zooming: Zooming
  repeat: boolean
  setRepeat: (repeat: boolean) => void
  help: boolean
  setHelp: (help: boolean) => void
  saving: boolean
  setSaving: (saving: boolean) => void
}) {
  const { desk, zooming } = props
  const { edits, take } = desk
  const changed = edits.done.length > 0
  const history = {
    canUndo: changed,
    canRedo: edits.undone.length > 0,
    undo: () => edits.undo(),
    redo: () => edits.redo(),
  }
  return (
    <div class="tl-transport" role="toolbar" aria-label="Transport">
      <PlayButtons {...props} by={take.film > 0 ? 1 : take.step} />
      <Counter player={props.player} fps={take.fps} last={filmLength(take) - 1} />
      <Steps desk={desk} />
      <Betweens desk={desk} />
      <div class="tl-right">
        <span class="soft small" role="status">
          {edits.busy ? 'Poses …' : changed ? 'Not saved' : ''}
        </span>
        <History editing={history} />
        <Zoom zoom={zooming.zoom} setZoom={zooming.setZoom} />
        <HelpButton help={props.help} setHelp={props.setHelp} />
        <div class="take-keep">
          <button
            class="main"
            disabled={!changed}
            aria-expanded={props.saving}
            onClick={() => props.setSaving(!props.saving)}
          >
            Save as…
          </button>
          {props.saving && changed && <SaveForm desk={desk} close={() => props.setSaving(false)} />}
        </div>
      </div>
    </div>
  )
}
