// With which puppet a take is shown: its description and chains, and the character that it moves.
// Asked where the files were not found by themselves, or are others than one wants.
import { useEffect, useState } from 'preact/hooks'

import { ApiError } from '../../api'
import { useStudio } from '../../state'
import { armatureApi } from '../armature/armature_api'
import type { ArmatureSetup, ArmatureStory } from '../armature/armature_api'
import { kFirstSetup, kNeeded, kOptional, problemsOf } from '../armature/setup'
import { FileFields, UpFields } from '../armature/setup_form'
import { takeApi } from './take_api'

/** What is known of it already; what is not stays empty. Null: there is no such take. */
async function knownSetup(take: string): Promise<ArmatureSetup | null> {
  const first = { ...kFirstSetup, take }
  return takeApi.setup(take).then(
    (known) => ({ ...first, ...known }),
    (error) => (error instanceof ApiError && error.status === 404 ? null : first),
  )
}

export function PuppetForm(props: { take: string; opened: () => void; close?: () => void }) {
  const { take, opened } = props
  const { complain } = useStudio()
  const [story, setStory] = useState<ArmatureStory | null>(null)
  const [setup, setSetup] = useState<ArmatureSetup | null>(null)
  const [tried, setTried] = useState(false)
  const [busy, setBusy] = useState(false)
  useEffect(() => {
    armatureApi.story().then(setStory, complain)
    void knownSetup(take).then(setSetup)
  }, [take, complain])
  if (!story || !setup) return null
  const problems = problemsOf(setup)
  const open = async () => {
    setTried(true)
    if (problems.description || problems.chains) return
    setBusy(true)
    try {
      await takeApi.open(take, setup)
      opened()
    } catch (error) {
      complain(error)
      setBusy(false)
    }
  }
  const fields = {
    setup,
    story,
    problems: tried ? problems : {},
    set: (change: Partial<ArmatureSetup>) => setSetup({ ...setup, ...change }),
  }
  return (
    <form
      class="card take-puppet"
      aria-label="The puppet’s files"
      onSubmit={(event) => {
        event.preventDefault()
        if (!busy) void open()
      }}
    >
      <FileFields {...fields} fields={kNeeded} />
      <FileFields {...fields} fields={kOptional} />
      <UpFields {...fields} />
      <div class="row">
        <button class="main" disabled={busy}>
          {busy ? 'Opens …' : 'Open the take'}
        </button>
        {props.close && (
          <button type="button" class="quiet" onClick={props.close}>
            Cancel
          </button>
        )}
      </div>
      <p class="small soft">Files below the project’s folder ‘armature’.</p>
    </form>
  )
}
